"""Pictures as arrays and files: colour scales, legends, PNG and EXR. numpy and the standard library only; no bpy."""
