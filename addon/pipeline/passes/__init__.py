"""The passes of a picture: G-buffer, shadow maps, shading."""
