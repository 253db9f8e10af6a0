//! The token that binds a model description to its resources: FMI 2 calls it GUID, FMI 3 instantiation token.
//! An instance computes it again from what it has opened, so that a description and a file that do not belong
//! together are refused.

/// Bytes of a token.
pub const LENGTH: usize = 38;

/// The token of a file and its points, as text: `{8-4-4-4-12}` hexadecimal digits. It is made of the
/// checksums and the length of both and of the version of this library, whose list of variables it vouches
/// for.
#[must_use]
pub fn token(file: &[u8], points: &[u8]) -> [u8; LENGTH] {
    let numbers = [
        crc32fast::hash(file),
        file.len() as u32,
        crc32fast::hash(points),
        crc32fast::hash(env!("CARGO_PKG_VERSION").as_bytes()) ^ points.len() as u32,
    ];
    let mut digits = numbers.iter().flat_map(|number| {
        (0..8).rev().map(move |place| match (number >> (4 * place)) as u8 & 15 {
            digit @ 0..10 => b'0' + digit,
            digit => b'a' + digit - 10,
        })
    });
    let mut text = *b"{........-....-....-....-............}";
    for place in text.iter_mut().filter(|place| **place == b'.') {
        *place = digits.next().unwrap_or(b'0');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::token;

    #[test]
    fn every_part_counts() {
        let one = token(b"file", b"points");
        assert_eq!(one.iter().filter(|byte| byte.is_ascii_hexdigit()).count(), 32);
        for other in [token(b"filf", b"points"), token(b"file", b"point"), token(b"file\0", b"points")] {
            assert_ne!(one, other);
        }
    }
}
