"""A small STEP writer, independent of the reader: boxes as solids of plane faces, products, occurrences, colours, what is hidden."""

import itertools

import numpy as np

HEAD = (
    "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
    "FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\n"
)
UNITS = {"mm": "SI_UNIT(.MILLI.,.METRE.)", "m": "SI_UNIT($,.METRE.)", "cm": "SI_UNIT(.CENTI.,.METRE.)"}


def real(value):
    text = repr(float(value)).upper()
    mantissa, mark, exponent = text.partition("E")
    return (mantissa if "." in mantissa else mantissa + ".") + mark + exponent


class Step:
    """A file that grows; every method gives the number of the statement that stands for what it made."""

    def __init__(self, unit="mm"):
        self.lines = []
        self.context = self.add("APPLICATION_CONTEXT('design')")
        self.product_context = self.add(f"PRODUCT_CONTEXT('',#{self.context},'mechanical')")
        self.definition_context = self.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',#{self.context},'design')")
        if unit == "in":
            base = self.add("( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )")
            measure = self.add(f"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#{base})")
            size = self.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)")
            length = self.add(f"( CONVERSION_BASED_UNIT('INCH',#{measure}) LENGTH_UNIT() NAMED_UNIT(#{size}) )")
        else:
            length = self.add(f"( LENGTH_UNIT() NAMED_UNIT(*) {UNITS[unit]} )")
        angle = self.add("( NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.) )")
        solid = self.add("( NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT() )")
        near = self.add(f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-05),#{length},'distance_accuracy_value','')")
        self.units = self.add(
            f"( GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{near})) GLOBAL_UNIT_ASSIGNED_CONTEXT("
            f"(#{length},#{angle},#{solid})) REPRESENTATION_CONTEXT('','') )"
        )
        self.origin = self.axes()

    def add(self, text):
        self.lines.append(text)
        return len(self.lines)

    def text(self):
        return HEAD + "DATA;\n" + "".join(f"#{i + 1}={line};\n" for i, line in enumerate(self.lines)) + "ENDSEC;\nEND-ISO-10303-21;\n"

    def point(self, p):
        return self.add(f"CARTESIAN_POINT('',({','.join(map(real, p))}))")

    def direction(self, d):
        return self.add(f"DIRECTION('',({','.join(map(real, d))}))")

    def axes(self, at=(0, 0, 0), z=(0, 0, 1), x=(1, 0, 0)):
        return self.add(f"AXIS2_PLACEMENT_3D('',#{self.point(at)},#{self.direction(z)},#{self.direction(x)})")

    def box(self, size, at=(0, 0, 0), name=""):
        """A solid of six plane faces."""
        corners = [tuple(a + s * bit for a, s, bit in zip(at, size, bits, strict=True)) for bits in itertools.product((0, 1), repeat=3)]
        vertices = [self.add(f"VERTEX_POINT('',#{self.point(c)})") for c in corners]
        edges = {}

        def edge(i, j):
            if (i, j) not in edges and (j, i) not in edges:
                way = np.subtract(corners[j], corners[i])
                length = float(np.linalg.norm(way))
                vector = self.add(f"VECTOR('',#{self.direction(way / length)},{real(length)})")
                line = self.add(f"LINE('',#{self.point(corners[i])},#{vector})")
                edges[i, j] = self.add(f"EDGE_CURVE('',#{vertices[i]},#{vertices[j]},#{line},.T.)")
            sense = (i, j) in edges
            return self.add(f"ORIENTED_EDGE('',*,*,#{edges[(i, j) if sense else (j, i)]},.{'T' if sense else 'F'}.)")

        faces = []
        for ring in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)):
            a, b, c = (np.array(corners[i], float) for i in ring[:3])
            normal = np.cross(b - a, c - a)
            loop = self.add("EDGE_LOOP('',(" + ",".join(f"#{edge(i, j)}" for i, j in zip(ring, ring[1:] + ring[:1], strict=True)) + "))")
            plane = self.add(f"PLANE('',#{self.axes(a, normal / np.linalg.norm(normal), (b - a) / np.linalg.norm(b - a))})")
            bound = self.add(f"FACE_OUTER_BOUND('',#{loop},.T.)")
            faces.append(self.add(f"ADVANCED_FACE('',(#{bound}),#{plane},.T.)"))
        shell = self.add("CLOSED_SHELL('',(" + ",".join(f"#{f}" for f in faces) + "))")
        return self.add(f"MANIFOLD_SOLID_BREP('{name}',#{shell})")

    def product(self, name, *solids, identifier=None):
        """A product of these solids; (definition, representation). Without solids it is there to hold others."""
        product = self.add(f"PRODUCT('{name if identifier is None else identifier}','{name}','',(#{self.product_context}))")
        formation = self.add(f"PRODUCT_DEFINITION_FORMATION('','',#{product})")
        definition = self.add(f"PRODUCT_DEFINITION('design','',#{formation},#{self.definition_context})")
        shape = self.add(f"PRODUCT_DEFINITION_SHAPE('','',#{definition})")
        kind = "ADVANCED_BREP_SHAPE_REPRESENTATION" if solids else "SHAPE_REPRESENTATION"
        items = ",".join(f"#{i}" for i in (self.origin, *solids))
        representation = self.add(f"{kind}('',({items}),#{self.units})")
        self.add(f"SHAPE_DEFINITION_REPRESENTATION(#{shape},#{representation})")
        return definition, representation

    def occurrence(self, holder, product, name="", identifier="1", **place):
        """The product placed within another; (occurrence, context of its styles)."""
        axes = self.axes(**place)
        move = self.add(f"ITEM_DEFINED_TRANSFORMATION('','',#{self.origin},#{axes})")
        relation = self.add(
            f"( REPRESENTATION_RELATIONSHIP('','',#{product[1]},#{holder[1]}) REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{move}) "
            "SHAPE_REPRESENTATION_RELATIONSHIP() )"
        )
        use = self.add(f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{identifier}','{name}','',#{holder[0]},#{product[0]},$)")
        shape = self.add(f"PRODUCT_DEFINITION_SHAPE('Placement','',#{use})")
        return use, self.add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relation},#{shape})")

    def style(self, color, alpha=1.0):
        """The styles of a surface of that colour (sRGB, or a name)."""
        tint = (
            f"DRAUGHTING_PRE_DEFINED_COLOUR('{color}')" if isinstance(color, str) else f"COLOUR_RGB('',{','.join(real(c) for c in color)})"
        )
        colour = self.add(tint)
        area = self.add(f"FILL_AREA_STYLE('',(#{self.add(f'FILL_AREA_STYLE_COLOUR({chr(39) * 2},#{colour})')}))")
        sides = [self.add(f"SURFACE_STYLE_FILL_AREA(#{area})")]
        if alpha < 1.0:
            clear = self.add(f"SURFACE_STYLE_TRANSPARENT({real(1 - alpha)})")
            sides.append(self.add(f"SURFACE_STYLE_RENDERING_WITH_PROPERTIES(.NORMAL_SHADING.,#{colour},(#{clear}))"))
        side = self.add("SURFACE_SIDE_STYLE('',(" + ",".join(f"#{s}" for s in sides) + "))")
        return self.add(f"SURFACE_STYLE_USAGE(.BOTH.,#{side})")

    def colored(self, item, color, alpha=1.0):
        """A styled item: the colour of a solid."""
        assignment = self.add(f"PRESENTATION_STYLE_ASSIGNMENT((#{self.style(color, alpha)}))")
        styled = self.add(f"STYLED_ITEM('',(#{assignment}),#{item})")
        self.add(f"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',(#{styled}),#{self.units})")
        return styled

    def colored_occurrence(self, item, over, context, color):
        """A colour that a solid has in one occurrence only."""
        style = self.add(f"PRESENTATION_STYLE_BY_CONTEXT((#{self.style(color)}),#{context})")
        return self.add(f"OVER_RIDING_STYLED_ITEM('',(#{style}),#{item},#{over})")

    def hidden(self, *items):
        return self.add("INVISIBILITY((" + ",".join(f"#{i}" for i in items) + "))")

    def document(self, product, file):
        """A product that another file describes."""
        kind = self.add("DOCUMENT_TYPE('')")
        document = self.add(f"DOCUMENT('','',$,#{kind})")
        own = self.add(f"PRODUCT('doc {file}','{file}','',(#{self.product_context}))")
        formation = self.add(f"PRODUCT_DEFINITION_FORMATION('1','',#{own})")
        held = self.add(f"DOCUMENT_FILE('{file}','',$,#{kind},'',$)")
        self.add(f"PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS('1','',#{formation},#{self.definition_context},(#{held}))")
        self.add(f"DOCUMENT_PRODUCT_EQUIVALENCE('equivalence',$,#{document},#{formation})")
        return self.add(f"APPLIED_DOCUMENT_REFERENCE(#{document},'',(#{product[0]}))")
