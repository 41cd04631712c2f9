//! Linear matrix inequalities, modelled as they are written and verified outside the solver
