//! The Riccati equations, of a size known when compiling and when running.

mod dynamic;
mod fixed;
