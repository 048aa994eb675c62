"""The networks of Neural Layered BRDFs (Fan, Wang, Hašan, Yang and Yan, SIGGRAPH 2022)."""
