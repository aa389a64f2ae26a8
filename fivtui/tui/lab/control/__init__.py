"""What computes in the background for the main screen: live curve, search and gauges."""
