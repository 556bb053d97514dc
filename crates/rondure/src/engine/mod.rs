//! Engines: how the pieces that a ray may hit are found among all of them.

mod shell_tree;

pub(crate) use shell_tree::ShellTree;
