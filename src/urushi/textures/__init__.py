"""Materials that vary over a surface: axes, their nodes, and files of texels."""
