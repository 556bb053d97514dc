//! An independent, slow, exact oracle for `rondure`, and the suites that hold `rondure` to it.
//!
//! Nothing here uses rondure's numerics: only its types for profiles, rays and maps. Every f64 is
//! taken for exactly the number that it is, and everything that is decided is decided in integers.
//!
//! [`Oracle`] finds all hits of a line; [`closed_form`] finds those of four solids by other means;
//! [`Tally`] compares a surface with either and counts what is wrong.

pub mod agree;
pub mod closed;
pub mod closed_form;
pub mod compare;
pub mod cuts;
pub mod exact;
pub mod laws;
pub mod oracle;
pub mod pieces;
pub mod polynomial;
pub mod profiles;
pub mod random;
pub mod solids;
pub mod suites;
pub mod trigonometry;
pub mod views;

pub use compare::{Tally, Target};
pub use oracle::{ExactLine, Oracle, OracleHit};
pub use random::Random;
