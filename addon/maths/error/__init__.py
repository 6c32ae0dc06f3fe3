"""How wrong a map or a picture is: predicted, measured, compared. numpy only."""
