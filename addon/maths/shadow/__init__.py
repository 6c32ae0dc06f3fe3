"""Shadow maps: warps, partitions, fitting, and the definition of the shadow tests. numpy only."""
