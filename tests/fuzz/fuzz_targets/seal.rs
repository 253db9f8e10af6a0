//! Makes the checksums of mutated bytes right again, so that what lies behind them is reached.

const BLOCK: usize = vademecum_format::BLOCK;

fn number<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes[at..at + N].try_into().expect("in the header or the directory")
}

/// New checksums for sections, metadata, directory, header, and the true length, as far as the bytes reach.
pub fn seal(mut bytes: Vec<u8>) -> Vec<u8> {
    if bytes.len() < BLOCK {
        return bytes;
    }
    let length = bytes.len();
    bytes[16..24].copy_from_slice(&(length as u64).to_le_bytes());
    let n = u32::from_le_bytes(number(&bytes, 12)).min(256) as usize;
    let end = (BLOCK * (1 + n)).min(length);
    for at in (BLOCK..end).step_by(BLOCK).take_while(|at| at + BLOCK <= end) {
        let start = u64::from_le_bytes(number(&bytes, at + 32)).min(length as u64) as usize;
        let stored = u64::from_le_bytes(number(&bytes, at + 40)).min((length - start) as u64) as usize;
        let crc = crc32fast::hash(&bytes[start..start + stored]);
        bytes[at + 56..at + 60].copy_from_slice(&crc.to_le_bytes());
    }
    let metadata = u64::from_le_bytes(number(&bytes, 32)).min((length - end) as u64) as usize;
    let crc = crc32fast::hash(&bytes[end..end + metadata]);
    bytes[40..44].copy_from_slice(&crc.to_le_bytes());
    let crc = crc32fast::hash(&bytes[BLOCK..end]);
    bytes[44..48].copy_from_slice(&crc.to_le_bytes());
    let crc = crc32fast::hash(&bytes[..60]);
    bytes[60..64].copy_from_slice(&crc.to_le_bytes());
    bytes
}
