"""The scene on the GPU: pools, clusters, draw lists."""
