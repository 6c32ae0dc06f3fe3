"""The words of the tab in other languages than English. Blender looks them up by the English words; what is not here stays English.

A language is one table more in `TABLES`. Words of buttons stand in Blender's context "Operator", all others in none ("*"): both get all.
"""

from __future__ import annotations

import bpy

CONTEXTS = ("*", "Operator")
GERMAN = {
    "Preview": "Vorschau",
    "Live View": "Live-Ansicht",
    "Look": "Stil",
    "Quality": "Qualität",
    "Custom": "Eigene",
    "Light": "Licht",
    "Automatic": "Automatisch",
    "Light Object": "Lichtobjekt",
    "Direction": "Richtung",
    "Follows the View": "Folgt der Ansicht",
    "Azimuth": "Azimut",
    "Elevation": "Höhe",
    "Strength": "Stärke",
    "Sun by Place and Time": "Sonne nach Ort und Zeit",
    "Sun over a Day": "Sonne über einen Tag",
    "Sun Hours": "Sonnenstunden",
    "Sun Path": "Sonnenbahn",
    "Place Sun": "Sonne stellen",
    "Colors and Ambient Light": "Farben und Umgebungslicht",
    "Edges": "Kanten",
    "Ground": "Boden",
    "Section": "Schnitt",
    "Camera": "Kamera",
    "Sharpness of Shadows": "Schärfe der Schatten",
    "Smooth Edges": "Glatte Kanten",
    "Samples": "Abtastungen",
    "Map Size": "Kartengröße",
    "Live View Pixel": "Pixel der Live-Ansicht",
    "Detail Near and Far": "Feinheit nah und fern",
    "Parts of the View": "Teile der Ansicht",
    "Test and Softness": "Test und Weichheit",
    "Stray Shadows": "Falsche Schatten",
    "By Hand": "Von Hand",
    "Impostors": "Impostoren",
    "Capture": "Aufnahme",
    "Life Cycle": "Lebenszyklus",
    "Keep": "Aufbewahren",
    "Advice": "Rat",
    "Measure and Explain": "Messen und erklären",
    "Export": "Ausgeben",
    "CAD model (.step, .glb, …)": "CAD-Modell (.step, .glb, …)",
    "Import CAD": "CAD importieren",
    "CAD": "CAD",
    "Clay": "Ton",
    "Technical": "Technisch",
    "Sun Study": "Sonnenstudie",
    "Oil Platform": "Ölplattform",
    "Reference": "Referenz",
}
TABLES = {"de_DE": GERMAN, "de": GERMAN}  # Blender calls the language by the first, systems may by the second


def words() -> dict[str, dict[tuple[str, str], str]]:
    """What Blender is given: by language, (context, English) and the word."""
    return {code: {(context, text): word for text, word in table.items() for context in CONTEXTS} for code, table in TABLES.items()}


def register() -> None:
    """Let Blender know the words."""
    bpy.app.translations.register(__name__, words())


def unregister() -> None:
    """Take them back."""
    bpy.app.translations.unregister(__name__)
