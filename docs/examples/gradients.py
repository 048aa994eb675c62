"""The code of the page "Gradients": the gradient of a picture with respect to a coat's albedo."""

import drjit as dr
import mitsuba as mi

import urushi  # noqa: F401 (registers the plugins)

mi.set_variant("llvm_ad_rgb")

SIZE = 16
gold = {"type": "roughconductor", "material": "Au", "distribution": "ggx", "alpha": 0.2}
lacquer = {
    "type": "neural_layered",
    "albedo": {"type": "rgb", "value": [0.8, 0.3, 0.1]},
    "sigma_t": 1.0,
    "bottom": gold,
}
scene = mi.load_dict(
    {
        "type": "scene",
        "camera": {
            "type": "perspective",
            "to_world": mi.ScalarTransform4d().look_at([0, -4, 0], [0, 0, 0], [0, 0, 1]),
            "film": {"type": "hdrfilm", "width": SIZE, "height": SIZE},
        },
        "sky": {"type": "constant"},
        "object": {"type": "sphere", "bsdf": lacquer},
    }
)
target = dr.full(mi.TensorXf, 0.5, (SIZE, SIZE, 3))

# [gradient]
parameters = mi.traverse(scene)
key = "object.bsdf.albedo.value"  # ....data if it is a bitmap
dr.enable_grad(parameters[key])
parameters.update()
image = mi.render(scene, parameters, integrator=mi.load_dict({"type": "prb"}))
dr.backward(dr.mean(dr.square(image - target), axis=None))
gradient = parameters[key].grad
# [end gradient]

print(gradient)
