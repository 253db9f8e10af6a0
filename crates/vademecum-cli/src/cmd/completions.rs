//! `vademecum completions`: what a shell needs to complete arguments.

/// Prints a script that has a shell complete the arguments of this program.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum completions bash > ~/.local/share/bash-completion/completions/vademecum
  vademecum completions zsh > ~/.zfunc/_vademecum           with `fpath+=~/.zfunc` before `compinit`
  vademecum completions fish > ~/.config/fish/completions/vademecum.fish
  vademecum completions powershell >> $PROFILE")]
pub(crate) struct Completions {
    /// The shell.
    #[arg(value_enum)]
    shell: clap_complete::Shell,
}

impl Completions {
    /// Prints the script for `program`, the whole command line.
    pub(crate) fn run(&self, mut program: clap::Command) {
        let mut script = vec![];
        clap_complete::generate(self.shell, &mut program, "vademecum", &mut script);
        println!("{}", String::from_utf8_lossy(&script).trim_end());
    }
}
