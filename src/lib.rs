//! Preslide
#![no_std]
