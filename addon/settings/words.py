"""The words that explain each choice: (label, what it does to the picture), in the order of the choices. No bpy.

Warps, partition schemes and shadow tests bring their own (`maths/warping`, `maths/partitioning`, `shadowing`).
"""

from .groups import PCF_COUNTS, SAMPLE_COUNTS, SMOOTHINGS

CUT_WORDS = (
    (
        "Automatic",
        "Halves or slices along the light, whichever have the smaller texels in this view; halves unless fitted to visible surfaces",
    ),
    (
        "Halves along the light",
        "Half as many slices, in two halves each, cut along the light's rays: the sharpest at an object. A sun; 4, 6 or 8 maps",
    ),
    ("Along the light", "Slices end along the light's rays, so that no two maps cover the same ground. For a sun"),
    ("Across the view", "Slices end at view depths, as in the texts (T4 §4.3.2): maps overlap unless the light falls across the view"),
)
FIT_WORDS = (
    ("View frustum", "Texels are spread over all that the camera could see"),
    ("Scene", "Texels are spread over the part of the view that holds the scene"),
    ("Visible surfaces", "Texels are spread over the surfaces really in the picture: the sharpest, above all when looking at one object"),
)
BIAS_WORDS = (
    ("Automatic", "From the footprint of the texel and the slope of the surface at every pixel; nothing to tune"),
    ("Constant", "One distance along the light, in metres"),
    ("Slope-scaled", "Grows with the slope of the surface against the light, in texels"),
    ("Normal offset", "Moves the surface along its normal, in texels"),
    ("Receiver plane", "Follows the plane of the surface within the filter"),
)
CASTER_WORDS = (
    ("Full", "Maps are drawn with every triangle"),
    ("Full, coarse in the live view", "The live view's maps are drawn with coarser meshes as soon as they are made; pictures are not"),
    ("Coarse", "All maps are drawn with coarser meshes; a picture waits until they are made, once for each mesh"),
)
FILTER_UNIT_WORDS = (
    ("Texels", "The filter is so many texels of the shadow map wide: its softness follows the warp"),
    ("Pixels", "The filter is so many pixels of the picture wide, whatever the warp"),
    ("Metres", "The filter is so many metres wide across the light's ray, whatever the warp"),
)
DISPLAY_WORDS = (
    ("Shaded", "The lit picture"),
    ("Shadow", "Only the light that arrives, in grey"),
    ("Aliasing", "The lit picture tinted by the error m: picture pixels per shadow-map texel"),
    ("Partitions", "The lit picture tinted by the shadow map that serves each pixel"),
)
CONVERGENCE_WORDS = (
    ("Quadratic", "Fast return to the warp: r = [1 + sin((γ/γ_lim − 1) π/2)]² (T4 (44))"),
    ("Sine", "Zhang's slower one: r = sin(γ/γ_lim · π/2) (T4 (43))"),
)

PCF_WORDS = tuple(
    (
        f"{k} sample" + "s" * (k > 1),
        f"{k} shadow test{'s' * (k > 1)} per pixel: {k + 1} levels of shadow at an edge with one depth per cell",
    )
    for k in PCF_COUNTS
)
SMOOTHING_WORDS = tuple(
    ("Off", "One test for every camera sample: edges of shadows have stairs")
    if k == 1
    else (f"{k} tests", f"{k} tests for every camera sample that the edge of a shadow may pass, one for all others")
    for k in SMOOTHINGS
)
SAMPLE_WORDS = tuple(
    (f"{k} per pixel", f"{k} camera sample{'s' * (k > 1)} per pixel of the picture; the data passes stay at pixel centres")
    for k in SAMPLE_COUNTS
)
IMPOSTOR_USE_WORDS = (
    ("Automatic", "Captured at first sight, warped while the predicted error is within its limit, then captured anew"),
    ("Manual", "Captured at first sight, then only when asked to (Regenerate); where the texture would be wrong geometry is drawn"),
    ("Off", "All is drawn as geometry; the marks stay"),
)
IMPOSTOR_PROJECTION_WORDS = (
    ("Perspective", "From the eye of the view: exactly the picture there, nothing visible is missed"),
    ("Orthographic", "Parallel rays, as in the text (RI §5.2): misses a little of what is seen from near, even at its own eye"),
)
IMPOSTOR_WARP_WORDS = (
    ("Follow Rays", "Each pixel follows its view ray through the depths of the texture, front and back: the most exact"),
    ("Pre-Warp", "The texels are moved first, holes filled by interpolation (RI 5-3, 5-4): as in the text"),
)
IMPOSTOR_CASTER_WORDS = (
    ("Geometry", "Their triangles cast the shadows: exact, and drawn into every shadow map"),
    ("Impostors", "Captured once from the light, they cast shadows from that texture: cheaper, a little less exact at its edges"),
)
PREDICTOR_WORDS = (
    ("Critical Point", "E_u² + E_v² of the neighbouring texels with the largest step in depth, as written (RI 5-5 to 5-7)"),
    ("Critical Point, Corrected", "By how many pixels that pair opens along its own axis; a pair at rest counts 0"),
    ("Regions, Sum", "The sum over one critical point in each of 4 × 4 regions, as written (RI §5.6)"),
    ("Regions, Largest", "The largest of the 4 × 4 critical points, as written (RI §5.6)"),
    ("Regions Corrected, Sum", "The sum of the corrected openings of 4 × 4 regions, pixels"),
    ("Regions Corrected, Largest", "The largest corrected opening of 4 × 4 regions, pixels"),
    ("Regions, Share", "The share of the 4 × 4 regions that open by more than a pixel"),
    ("Edge Sum, as Written", "The pixels that open behind the depth edges and the outline: Σ max(0, (s_fg − s_bg)(p − e)·n)"),
    ("Edge Sum", "The pixels that come into view behind all depth edges, as a share of those covered: follows the truth best"),
    ("Edge Sum, Fast", "The edge sum from directional sums made at capture: nearly as good at a fixed cost"),
)
GROUND_WORDS = (
    ("Off", "No ground: the model floats before the background"),
    ("Under the Model", "Just below the lowest visible part; its shadows fade out round the model"),
    ("At a Height", "At the height given below"),
)
CAP_WORDS = (
    ("Solid", "Cut faces of closed bodies are filled with one color"),
    ("Hatched", "Cut faces are filled and hatched, every other part the other way round, as on a drawing"),
    ("None", "Cut bodies are seen into"),
)

SKY_WORDS = (
    ("Flat", "From the half of the world that a surface is turned to, whatever stands before it: nothing is darker in corners"),
    ("Uniform", "From a sky and a ground that are equally bright all over, stopped by what stands before them, near and far"),
    ("Clear", "From a clear sky, brightest round the sun (CIE), stopped likewise"),
    ("Overcast", "From an overcast sky, brightest overhead (CIE), stopped likewise"),
    ("World", "As Uniform, in the colors of the scene's world, whatever ambient light is chosen by hand"),
)

LIGHTS_WORDS = (
    ("All", "Every light that reaches what is seen, each with shadows of its own"),
    ("One", "Only the light that lights most of what is seen: faster"),
)
