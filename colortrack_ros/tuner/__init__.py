"""tuner: a web page to tune, watch and evaluate the chain of detector and tracker."""
