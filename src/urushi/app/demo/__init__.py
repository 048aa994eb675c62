"""The demo: a lacquered tea caddy with a maki-e pattern, by the walk and by the networks."""
