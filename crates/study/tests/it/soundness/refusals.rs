//! `refuted`, `no gain` and `no observer` need a witness against the observer or the plant.
