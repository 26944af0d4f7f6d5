//! Written glTF files, read back by another implementation and compared.

mod character;
mod dangling;
mod file;
mod fixtures;
mod foreign;
mod import;
mod mesh;
mod meshes;
mod motion;
mod read;
mod scenes;
mod text;
mod values;
