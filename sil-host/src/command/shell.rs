//! `sil completions` and `sil man`: what a shell and `man` want to know of the commands, generated from them.

use std::path::PathBuf;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{Arguments, Failure, failed, print, to_stdout};

/// Print the completions for a shell
#[derive(Args)]
#[command(after_help = "Example: sil completions bash > ~/.local/share/bash-completion/completions/sil")]
pub struct CompletionsArguments {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Print the manual page, or write one page per command
#[derive(Args)]
#[command(after_help = "Example: sil man --out ~/.local/share/man/man1")]
pub struct ManArguments {
    /// Write the pages of all commands into this folder
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

pub fn completions(arguments: &CompletionsArguments) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::command(), "sil", &mut script);
    to_stdout(String::from_utf8_lossy(&script))
}

pub fn man(arguments: &ManArguments) -> Result<(), Failure> {
    let Some(folder) = &arguments.out else {
        let mut page = Vec::new();
        clap_mangen::Man::new(Arguments::command()).render(&mut page).map_err(failed)?;
        return to_stdout(String::from_utf8_lossy(&page));
    };
    let cannot = |error| failed(format!("{}: cannot be written: {error}", folder.display()));
    std::fs::create_dir_all(folder).map_err(cannot)?;
    clap_mangen::generate_to(Arguments::command(), folder).map_err(cannot)?;
    print(format!("pages   {}\n", folder.display()))
}
