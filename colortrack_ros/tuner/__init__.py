"""tuner: a page to tune, watch and judge the chain of detector and tracker."""
