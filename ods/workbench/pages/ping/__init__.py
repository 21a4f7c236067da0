"""Parts of the image processing menu: stages with their sliders, pictures, curves."""
