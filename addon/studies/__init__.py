"""What is asked of pictures: run, report, write, compare, advise. No bpy."""
