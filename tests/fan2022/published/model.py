"""Networks with the classes and attributes of the authors' `model.py`, and few values.

`python save.py` with Python 3.7 and PyTorch 1.2 (`pip install torch==1.2.0 numpy`) writes the files
of this folder. All parameters are views of one storage.
"""

import torch.nn as nn


class residual(nn.Module):
    def __init__(self, module):
        super().__init__()
        self.module = module

    def forward(self, x):
        return self.module(x) + x


class layerer_residual_block(nn.Module):
    def __init__(self, n):
        super().__init__()
        self.fc1, self.fc2 = nn.Linear(n, n // 2), nn.Linear(n // 2, n)
        self.ln1, self.ln2 = nn.LayerNorm(n // 2), nn.LayerNorm(n)
        self.relu = nn.ReLU()

    def forward(self, x):
        return self.relu(self.ln2(x + self.fc2(self.relu(self.ln1(self.fc1(x))))))


def fc(inputs, outputs):
    return nn.Sequential(nn.Linear(inputs, outputs), nn.LayerNorm(outputs), nn.ReLU())


def nested(n, depth):
    if depth == 0:
        return layerer_residual_block(n)
    return residual(nn.Sequential(nested(n, depth - 1), fc(n, n), nested(n, depth - 1)))


class Decoder_0611_RGB(nn.Module):
    def __init__(self, config):
        super().__init__()
        self.model_name, self.config = type(self).__name__, config
        self.layer = nn.Sequential(fc(38, 256), nested(256, 3), fc(256, 256), nn.Linear(256, 1))

    def forward(self, x):
        return self.layer(x)


class LayererDecoderOnly_alsT_0611_RGB(nn.Module):
    def __init__(self, config):
        super().__init__()
        self.model_name, self.config = type(self).__name__, config
        n, block = 512, layerer_residual_block
        middle = nn.Sequential(block(n), fc(n, n), nested(n, 1), fc(n, n), block(n))
        self.layer = nn.Sequential(fc(66, n), residual(middle), fc(n, 128), nn.Linear(128, 32))

    def forward(self, x):
        return self.layer(x)
