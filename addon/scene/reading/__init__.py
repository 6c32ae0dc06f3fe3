"""CAD files read in a process of its own: a file that crashes, hangs or fills the memory costs that file, nothing else. No bpy."""
