"""Why a mission fails: losing regions, cut sets, critical events, FMECA, numbers of risk."""
