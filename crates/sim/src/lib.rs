//! Plants and observers in one run: trajectories, events, noise and metrics
