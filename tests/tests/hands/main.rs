//! Hands, devices and recordings.

mod exoskeleton;
mod live_hands;
mod pen;
mod placed_hands;
mod recorded_hands;
mod replay;
mod tactile;
mod torque;
mod view_contacts;
