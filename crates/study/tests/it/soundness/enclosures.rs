//! The enclosed Jacobian is the one that the certificate speaks of.
