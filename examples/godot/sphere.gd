extends Spatial

# Draws a few frames, writes the picture into the folder of the project and quits.
func _ready():
    for frame in range(4):
        yield(VisualServer, "frame_post_draw")
    var picture = get_viewport().get_texture().get_data()
    picture.flip_y()
    picture.save_png("res://sphere.png")
    get_tree().quit()
