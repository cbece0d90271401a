//! Host checks of Preslide.
