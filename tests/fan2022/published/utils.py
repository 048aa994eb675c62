"""Configurations with the attributes of the authors' `utils.py`."""


class Config:
    pass


class DecoderOnlyConfig(Config):
    def __init__(self):
        self.latent_size, self.layer_norm, self.is_cuda = 96, True, False
        self.compress_decoder = "Decoder_0611_RGB"
        self.decoder_path = "./saved_model/RepreNetwork.pth"


class LayerDecoderOnly_alsTN_Config(Config):
    def __init__(self):
        self.input_latent_size, self.latent_size = 32, 32
        self.layer_layer_norm, self.is_cuda = True, False
        self.layer_model = "LayererDecoderOnly_alsT_0611_RGB"
        self.layerer_path = "./saved_model/LayeringNetwork.pth"
