"""What is drawn: records, readers of CAD files, the sample deck. No bpy, no OpenGL."""
