// Only its include directories are of interest.
