//! Contents of a page that works by itself: its style, its modules and what is encoded in it.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;

/// The style of the pages.
pub(super) const STYLE: &str = include_str!("../../../assets/page/style.css");

/// The modules of a page as the names by which they import each other.
pub(super) fn import_map(modules: &[(&str, &str)]) -> String {
    let module = |(name, text): &(&str, &str)| {
        // Its name, for messages: a data address would be the whole module again.
        let text = format!("{text}//# sourceURL=vademecum/{name}.js\n");
        format!("\"vademecum/{name}\":\"data:text/javascript;base64,{}\"", BASE64.encode(text))
    };
    let modules: Vec<String> = modules.iter().map(module).collect();
    format!("{{\"imports\":{{{}}}}}", modules.join(","))
}

/// Bytes as a page holds them.
pub(super) fn encoded(bytes: &[u8]) -> String {
    BASE64.encode(bytes)
}
