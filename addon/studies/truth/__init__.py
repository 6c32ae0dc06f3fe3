"""Ray-traced truth: what a hard shadow really is at every pixel centre, and how far a preview is from it.

Not a renderer: one primary and one shadow ray per pixel, no shading. Geometry in float64, traversal by Blender's BVH (always there)
or Embree (a development dependency, ten times faster).
"""

from .compare import compare, compare_view
from .tracer import Truth, TruthTracer

__all__ = ["Truth", "TruthTracer", "compare", "compare_view"]
