//! `vademecum view`: the body in a browser, stepped there by the evaluator itself.
//!
//! One page serves both ways: from a small local server the page fetches the file, in an exported page the
//! file is inside. The page, its modules and the WebAssembly evaluator are part of the program (`assets/`),
//! so it makes no network requests.

use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use vademecum_build::progress::Listener;
use vademecum_build::store::{Kind, Outputs};
use vademecum_format::{File, FormatError, SectionKind};
use vademecum_study::FileError;

mod inside;
mod world;

use crate::arguments::{Limit, OutputArguments};
use crate::assets::evaluator;
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::files::{check_output, is_stepped, refuse_chapter, usable_file, write_bytes};
use crate::given::{Given, outputs_of};
use crate::html::{escaped, title};
use crate::print::print_json;
use inside::{STYLE, encoded, import_map};
use world::WorldPage;

const PAGE: &str = include_str!("../../assets/page/page.html");

macro_rules! modules {
    ($($name:literal),*) => {
        [$(($name, include_str!(concat!("../../assets/page/", $name, ".js")))),*]
    };
}

/// The page's JavaScript modules by the names they import each other with.
const MODULES: [(&str, &str); 24] = modules!(
    "body",
    "camera",
    "chart",
    "colors",
    "controls",
    "elements",
    "evaluator",
    "flight",
    "greet",
    "hands",
    "main",
    "modes",
    "overlay",
    "parameters",
    "player",
    "record",
    "render",
    "ring",
    "ringer",
    "share",
    "skin",
    "sound",
    "vectors",
    "views"
);

/// Path of the file on the served page.
const SOURCE: &str = "body.vdm";
/// Longest request head that is read \[bytes\].
const MAX_HEAD: usize = 16 * 1024;
/// Most connections answered at a time; a browser opens about six.
const MAX_CONNECTIONS: usize = 32;

/// Opens the body in a browser: push it, let it ring, change its parameters while it moves. Bodies of a world
/// are pulled, thrown and stacked.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum view body.vdm                       opens the browser on a page of this machine; Ctrl-C ends it
  vademecum view body.vdm --export body.html    one file that works from disk, without network, on a phone
  vademecum view world.toml                     bodies of an assembly file with `[world]`, which touch

On the page: press on the body to push it, drag beside it to turn the view. With Sound on, a struck body rings
in the ear; Picture and Clip save what is seen; Link puts camera and parameters into the address.")]
pub(crate) struct View {
    /// The vademecum file, or an assembly file (TOML), which is joined in memory or is a world.
    file: PathBuf,
    /// Print the address and do not open a browser.
    #[arg(long)]
    no_open: bool,
    /// Port on 127.0.0.1; a free one if absent.
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Write one self-contained page, file included, instead of serving.
    #[arg(long, value_name = "PAGE.html")]
    export: Option<PathBuf>,
    /// Print JSON: what `--export` has written.
    #[arg(long, requires = "export")]
    json: bool,
    /// Map the file into memory instead of copying it, for files too large to copy. Nobody may shorten or
    /// overwrite it meanwhile: the program would crash or give wrong numbers.
    #[arg(long)]
    map: bool,
    /// The default.
    #[arg(long, hide = true, conflicts_with = "map")]
    copy: bool,
    #[command(flatten)]
    outputs: OutputArguments,
    #[command(flatten)]
    limit: Limit,
}

/// Report of `--export`.
#[derive(serde::Serialize)]
struct PageOutput {
    page: String,
    bytes: usize,
}

impl View {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        let given = Given::look(&self.file)?;
        let outputs = outputs_of(&self.outputs, &given, &[Some(&self.file)]);
        if let Some(path) = &self.export {
            check_output(&outputs, path, Kind::Html)?;
        }
        if let Given::Assembly(file) = &given
            && file.world.is_some()
        {
            let world = WorldPage::new(file, &self.file, console)?;
            console.clear();
            return match &self.export {
                Some(path) => self.write(&outputs, path, &world.filled(true)),
                None => self.serve(&world.filled(false), &world.served(), console),
            };
        }
        let mapped = given.open(&self.file, self.map, console)?;
        let mut memory = vec![];
        // The page wants all of it raw; what is for people only may stay packed.
        let file = usable_file(&self.file, &mapped, is_stepped, self.limit, &mut memory)?;
        console.clear();
        match &self.export {
            Some(path) => self.write(&outputs, path, &page(&self.file, &file)?),
            None => {
                check(&self.file, &file)?;
                let served = [(format!("/{SOURCE}"), file.bytes())];
                self.serve(&filled(&title(&self.file, &file), SOURCE, &[]), &served, console)
            }
        }
    }

    fn write(&self, outputs: &Outputs, path: &Path, page: &str) -> Result<(), Failure> {
        write_bytes(outputs, path, Kind::Html, page.as_bytes())?;
        let written = PageOutput { page: path.display().to_string(), bytes: page.len() };
        if self.json {
            print_json(&written);
        } else {
            println!("{}: {} bytes, works from disk and without network", written.page, written.bytes);
        }
        Ok(())
    }

    fn serve(&self, page: &str, files: &[(String, &[u8])], console: &Console) -> Result<(), Failure> {
        let network = |error: std::io::Error| {
            Failure::new(Cause::Machine, format!("127.0.0.1:{}: {error}", self.port))
                .remedy("another `--port`, or none for a free one")
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, self.port)).map_err(network)?;
        listener.set_nonblocking(true).map_err(network)?;
        let address = listener.local_addr().map_err(network)?;
        println!("http://{address}/  (Ctrl-C ends)");
        // Whoever reads a pipe waits for this line.
        std::io::stdout().flush().map_err(network)?;
        if !self.no_open && !open_browser(&format!("http://{address}/")) {
            eprintln!("  note: no browser could be started; open the address above");
        }
        let live = AtomicUsize::new(0);
        let content = Served { address, page, files };
        std::thread::scope(|scope| {
            while !console.cancelled() {
                match listener.accept() {
                    Ok((stream, _)) if live.load(Ordering::Relaxed) < MAX_CONNECTIONS => {
                        live.fetch_add(1, Ordering::Relaxed);
                        scope.spawn(|| {
                            // A visitor who hangs up is no failure of ours.
                            let _ = content.answer(stream);
                            live.fetch_sub(1, Ordering::Relaxed);
                        });
                    }
                    Ok((stream, _)) => drop(stream),
                    Err(_) => std::thread::sleep(Duration::from_millis(20)),
                }
            }
        });
        Ok(())
    }
}

/// Served contents.
struct Served<'a> {
    address: SocketAddr,
    page: &'a str,
    /// Files beside the page, with their paths.
    files: &'a [(String, &'a [u8])],
}

impl Served<'_> {
    /// Answers one request and closes.
    fn answer(&self, mut stream: TcpStream) -> std::io::Result<()> {
        stream.set_nonblocking(false)?;
        stream.set_read_timeout(Some(Duration::from_secs(2)))?;
        stream.set_write_timeout(Some(Duration::from_secs(20)))?;
        let (status, kind, body) = match read_head(&mut stream)? {
            Some(head) => self.content(&head),
            None => ("431 Request Header Fields Too Large", "text/plain", &b"too long\n"[..]),
        };
        let head = format!(
            "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
             X-Content-Type-Options: nosniff\r\nCross-Origin-Resource-Policy: same-origin\r\nConnection: \
             close\r\n\r\n",
            body.len()
        );
        stream.write_all(head.as_bytes())?;
        stream.write_all(body)
    }

    /// Status, type and body for a request head. Only our own names for this machine are answered: another
    /// site that makes its name point here shall not read the file.
    fn content(&self, head: &str) -> (&'static str, &'static str, &[u8]) {
        let mut lines = head.split("\r\n");
        let mut request = lines.next().unwrap_or_default().split(' ');
        let (method, target) = (request.next().unwrap_or_default(), request.next().unwrap_or_default());
        let host =
            lines.filter_map(|line| line.split_once(':')).find(|(name, _)| name.eq_ignore_ascii_case("host"));
        let host = host.map(|(_, value)| value.trim()).unwrap_or_default();
        let ours = [self.address.to_string(), format!("localhost:{}", self.address.port())];
        if !ours.iter().any(|name| name == host) {
            return ("403 Forbidden", "text/plain", b"open the address that `vademecum view` printed\n");
        }
        match (method, target) {
            ("GET", "/") => ("200 OK", "text/html; charset=utf-8", self.page.as_bytes()),
            ("GET", path) => match self.files.iter().find(|(name, _)| name == path) {
                Some((_, file)) => ("200 OK", "application/octet-stream", file),
                None => ("404 Not Found", "text/plain", b"not here\n"),
            },
            _ => ("405 Method Not Allowed", "text/plain", b"only GET\n"),
        }
    }
}

/// The request up to its empty line; `None` if it is too long.
fn read_head(stream: &mut TcpStream) -> std::io::Result<Option<String>> {
    let (mut head, mut part) = (vec![], [0; 2048]);
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        if head.len() > MAX_HEAD {
            return Ok(None);
        }
        match stream.read(&mut part)? {
            0 => return Err(ErrorKind::UnexpectedEof.into()),
            n => head.extend_from_slice(&part[..n]),
        }
    }
    Ok(Some(String::from_utf8_lossy(&head).into_owned()))
}

/// The page of a file, with everything inside: it works from disk and without network. `path` is the name of
/// the file, for the title and for messages.
///
/// # Errors
/// [`Failure`]: a file that the page cannot show.
pub fn page(path: &Path, file: &File<'_>) -> Result<String, Failure> {
    check(path, file)?;
    Ok(filled(&title(path, file), "", file.bytes()))
}

/// The page with everything inside; `file` too unless it comes from `source`.
fn filled(title: &str, source: &str, file: &[u8]) -> String {
    // The file goes in last: what is in it is never searched for places to fill.
    PAGE.replace("{{title}}", &escaped(title))
        .replace("{{style}}", STYLE)
        .replace("{{modules}}", &import_map(&MODULES))
        .replace("{{source}}", source)
        .replace("{{wasm}}", &encoded(&evaluator()))
        .replace("{{body}}", &encoded(file))
}

/// The page draws the surface; say here what it could not use.
fn check(path: &Path, file: &File<'_>) -> Result<(), Failure> {
    refuse_chapter(path, file, "the viewer")?;
    let failed = |error: FormatError| Failure::file(path, error);
    for kind in [SectionKind::NodeCoordinates, SectionKind::Triangles, SectionKind::SurfaceBasis] {
        let missing = || Failure::file(path, FileError::Missing { kind });
        file.section(kind).ok_or_else(missing)?.raw().map_err(failed)?;
    }
    Ok(())
}

/// Asks the system to show an address; whether something was started.
fn open_browser(address: &str) -> bool {
    let (program, arguments): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("cmd", &["/C", "start", ""])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(arguments).arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_page_and_the_file_are_served_and_only_to_our_own_name() {
        let files = [(String::from("/body.vdm"), &b"file"[..])];
        let content = Served { address: ([127, 0, 0, 1], 4000).into(), page: "page", files: &files };
        let ask = |request: &str, host: &str| {
            content.content(&format!("{request} HTTP/1.1\r\nHost: {host}\r\n\r\n")).0
        };
        assert_eq!(ask("GET /", "127.0.0.1:4000"), "200 OK");
        assert_eq!(ask("GET /body.vdm", "localhost:4000"), "200 OK");
        assert_eq!(ask("GET /../etc/passwd", "localhost:4000"), "404 Not Found");
        assert_eq!(ask("POST /", "localhost:4000"), "405 Method Not Allowed");
        assert_eq!(ask("GET /body.vdm", "elsewhere.example:4000"), "403 Forbidden");
        assert_eq!(content.content("").0, "403 Forbidden");
    }

    #[test]
    fn a_page_holds_everything_and_asks_for_nothing() {
        let page = filled("a <b> {{body}}", "", b"\x01\x02\x03");
        assert!(page.contains("a &lt;b&gt; &#123;&#123;body}}"));
        assert!(page.contains("AQID</script>"));
        assert!(!page.contains("{{"), "every place is filled");
        let outside = ["http://", "https://", "//cdn", "src=\"/", "@import"];
        assert!(outside.iter().all(|text| !page.contains(text)));
        for (name, text) in MODULES.iter().chain(&world::MODULES) {
            assert!(outside[..2].iter().all(|part| !text.contains(part)), "{name}");
        }
    }
}
