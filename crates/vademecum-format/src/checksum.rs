//! The checksum of header, directory and sections: CRC-32 as in zip files and Ethernet.

/// The CRC-32 of some bytes.
#[cfg(feature = "full")]
pub fn checksum(bytes: &[u8]) -> u32 {
    crc32fast::hash(bytes)
}

#[cfg(not(feature = "full"))]
pub use small as checksum;

/// The same with a table of sixteen numbers, half a byte at a time.
#[cfg(any(test, not(feature = "full")))]
pub fn small(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for &byte in bytes {
        crc ^= u32::from(byte);
        for _ in 0..2 {
            // The index is below 16, as the table is long.
            crc = (crc >> 4) ^ TABLE.get((crc & 15) as usize).copied().unwrap_or(0);
        }
    }
    !crc
}

/// Contribution of four bits that leave the register.
#[cfg(any(test, not(feature = "full")))]
const TABLE: [u32; 16] = {
    let (mut table, mut k) = ([0; 16], 0);
    while k < table.len() {
        let (mut crc, mut bit) = (k as u32, 0);
        while bit < 4 {
            crc = (crc >> 1) ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 };
            bit += 1;
        }
        table[k] = crc;
        k += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use super::{checksum, small};

    #[test]
    fn both_checksums_are_those_of_the_standard() {
        // The check value of CRC-32/ISO-HDLC.
        assert_eq!(small(b"123456789"), 0xCBF4_3926);
        let bytes: [u8; 1000] = core::array::from_fn(|k| (k * k / 7) as u8);
        for length in [0, 1, 2, 15, 16, 17, 999, 1000] {
            assert_eq!(small(&bytes[..length]), checksum(&bytes[..length]), "{length} bytes");
        }
    }
}
