"""Relief impostors on the GPU: capture, life, drawing, shadows."""
