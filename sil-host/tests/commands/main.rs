//! The commands as a person runs them: the binary `sil` in an empty folder, judged by exit status, stdout, stderr and
//! the files it leaves (docs/commands.md). Beside them the library on damaged logs and models, in large numbers.

mod bad_files;
mod bad_inputs;
mod compare;
mod console;
mod damage;
mod demonstration;
mod diagnosis;
mod flights;
mod identify;
mod json;
mod labels;
mod logs;
mod maps;
mod montecarlo;
mod pages;
mod refine;
mod sil;
mod usage;
