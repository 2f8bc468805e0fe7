//! The repository itself: which room uses which, what an estimate takes, and where links lead.

mod estimates;
mod links;
mod rooms;
