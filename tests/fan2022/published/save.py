"""Write the bound method `state_dict` of both networks, and outputs; see `model.py`."""

import model
import numpy as np
import torch
import utils

torch.manual_seed(0)
values = {"torch": np.array(torch.__version__)}
for name, network in (
    ("Repre", model.Decoder_0611_RGB(utils.DecoderOnlyConfig())),
    ("Layering", model.LayererDecoderOnly_alsT_0611_RGB(utils.LayerDecoderOnly_alsTN_Config())),
):
    shared = 0.1 * torch.randn(2048)
    for index, module in enumerate(network.modules()):
        for kind, parameter in list(module.named_parameters(recurse=False)):
            shape = parameter.shape
            view = shared.as_strided(shape, (1,) * len(shape), 7 * index)
            setattr(module, kind, torch.nn.Parameter(view))
    inputs = torch.rand(5, network.layer[0][0].in_features)
    values[name + " inputs"] = inputs.numpy()
    values[name + " outputs"] = network(inputs).detach().numpy()
    torch.save(network.state_dict, name + "Network.pth")
np.savez("values.npz", **values)
