"""Error measures, and the evaluation of networks on stacks that they were not trained on."""
