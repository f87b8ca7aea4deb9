//! Real models, where they are on this machine.
