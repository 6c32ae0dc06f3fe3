"""Relief impostors: the warp, the capture frame, the predictors of error, the life cycle. numpy only."""
