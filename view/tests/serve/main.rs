//! The server as pages and programs meet it: who gets in, what is served, and what can be done.

#[path = "../common/mod.rs"]
mod client;
mod gate;
mod images;
mod saved;
mod studio;
