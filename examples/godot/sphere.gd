extends Spatial

# The texture of the material: half floats behind a header of 148 bytes.
func table():
    var file = File.new()
    file.open("res://material.dds", File.READ)
    file.seek(12)
    var height = file.get_32()
    var width = file.get_32()
    file.seek(24)
    var depth = file.get_32()
    var texture = Texture3D.new()
    texture.create(width, height, depth, Image.FORMAT_RGBAH, Texture.FLAG_FILTER)
    file.seek(148)
    for layer in range(depth):
        var image = Image.new()
        var data = file.get_buffer(8 * width * height)
        image.create_from_data(width, height, false, Image.FORMAT_RGBAH, data)
        texture.set_layer_data(image, layer)
    return texture

# Draws a few frames, writes the picture into the folder of the project and quits.
func _ready():
    $Mesh.mesh.material.set_shader_param("rest_table", table())
    for frame in range(4):
        yield(VisualServer, "frame_post_draw")
    var picture = get_viewport().get_texture().get_data()
    picture.flip_y()
    picture.save_png("res://sphere.png")
    get_tree().quit()
