//! The repository itself: which room uses which, and where links lead.

mod links;
mod rooms;
