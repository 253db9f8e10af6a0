//! Memory and files from the C library, which every host of an FMU has: with nothing else needed, the library
//! runs beside any version of it.
#![allow(unsafe_code)]

use core::ffi::{CStr, c_char, c_int, c_long, c_void};
use core::ptr::NonNull;

// Without std nobody else asks for it.
#[cfg_attr(feature = "bare", link(name = "c"))]
unsafe extern "C" {
    fn malloc(size: usize) -> *mut c_void;
    fn free(block: *mut c_void);
    fn fopen(path: *const c_char, mode: *const c_char) -> *mut c_void;
    fn fclose(file: *mut c_void) -> c_int;
    fn fread(at: *mut c_void, size: usize, count: usize, file: *mut c_void) -> usize;
    fn fseek(file: *mut c_void, offset: c_long, whence: c_int) -> c_int;
    fn ftell(file: *mut c_void) -> c_long;
}

/// `SEEK_SET` and `SEEK_END` of every C library.
const START: c_int = 0;
const END: c_int = 2;

/// Bytes left free above a file and its numbers; nobody has blocks near the end of the address space.
const LARGEST: usize = isize::MAX as usize / 2;

/// A block of memory, aligned to 16 bytes, that is given back when it is dropped.
#[derive(Debug)]
pub struct Block {
    at: NonNull<u8>,
    length: usize,
}

impl Block {
    /// A block of zeros; `None` if there is no memory.
    #[must_use]
    pub fn zeroed(length: usize) -> Option<Self> {
        if length > LARGEST {
            return None;
        }
        // SAFETY: any length may be asked for; `malloc` aligns for every type of C.
        let at = NonNull::new(unsafe { malloc(length.max(16)) }.cast::<u8>())?;
        // SAFETY: the block has that many bytes, and nobody else knows it.
        unsafe { at.as_ptr().write_bytes(0, length) };
        #[cfg(test)]
        tests::BLOCKS.with(|count| count.set(count.get() + 1));
        Some(Self { at, length })
    }

    /// Its bytes.
    #[must_use]
    pub const fn bytes(&self) -> &[u8] {
        // SAFETY: the block has that many bytes, written when it was made.
        unsafe { core::slice::from_raw_parts(self.at.as_ptr(), self.length) }
    }

    /// Its bytes, to be written.
    #[must_use]
    pub const fn bytes_mut(&mut self) -> &mut [u8] {
        // SAFETY: the same, and the block is borrowed as a whole.
        unsafe { core::slice::from_raw_parts_mut(self.at.as_ptr(), self.length) }
    }

    /// Its bytes for as long as the caller keeps the block.
    ///
    /// # Safety
    /// The block outlives what is made of them, and nobody writes it meanwhile.
    #[must_use]
    pub const unsafe fn lend(&self) -> &'static [u8] {
        // SAFETY: as the caller promises.
        unsafe { core::slice::from_raw_parts(self.at.as_ptr(), self.length) }
    }

    /// The block as numbers, for as long as the caller keeps it.
    ///
    /// # Safety
    /// The block outlives what is made of them, and nobody else reads or writes it meanwhile.
    #[must_use]
    pub const unsafe fn lend_numbers(&mut self) -> &'static mut [f64] {
        // SAFETY: aligned, as long, and zero bytes are zeros; the rest as the caller promises.
        unsafe { core::slice::from_raw_parts_mut(self.at.as_ptr().cast::<f64>(), self.length / 8) }
    }

    /// The block as numbers.
    #[must_use]
    pub const fn numbers_mut(&mut self) -> &mut [f64] {
        // SAFETY: the borrow of the block is that of its numbers.
        unsafe { self.lend_numbers() }
    }

    /// Gives the block away; [`Block::of_raw`] takes it back.
    #[must_use]
    pub fn into_raw(self) -> NonNull<u8> {
        let at = self.at;
        core::mem::forget(self);
        at
    }

    /// Takes a block back.
    ///
    /// # Safety
    /// `at` is from [`Block::into_raw`] of a block of this length, and nobody else takes it.
    #[must_use]
    pub const unsafe fn of_raw(at: NonNull<u8>, length: usize) -> Self {
        Self { at, length }
    }

    /// A whole file.
    ///
    /// # Errors
    /// Reason of a failed allocation, in words.
    pub fn read(path: &CStr) -> Result<Self, &'static str> {
        let file = Stream::open(path)?;
        let length = file.length().ok_or("the length of the file cannot be found")?;
        let mut block = Self::zeroed(length).ok_or("there is no memory for the file")?;
        file.fill(block.bytes_mut()).ok_or("the file cannot be read")?;
        Ok(block)
    }
}

impl Drop for Block {
    fn drop(&mut self) {
        #[cfg(test)]
        tests::BLOCKS.with(|count| count.set(count.get() - 1));
        // SAFETY: from `malloc`, and given back once.
        unsafe { free(self.at.as_ptr().cast()) }
    }
}

/// Blocks that are handed out by pointer. They are freed one by one ([`Chain::free`]) or with their chain,
/// the rest of them.
#[derive(Debug)]
pub struct Chain {
    /// A link without content, whose neighbours are the first and the last block.
    ends: NonNull<Link>,
}

/// Front of a block of a chain; the content is behind it.
#[derive(Debug)]
#[repr(C, align(16))]
struct Link {
    length: usize,
    before: NonNull<Self>,
    after: NonNull<Self>,
}

impl Link {
    /// A link with room for a content, its own neighbour on both sides.
    fn new(length: usize) -> Option<NonNull<Self>> {
        let at = Block::zeroed(size_of::<Self>().checked_add(length)?)?.into_raw().cast::<Self>();
        // SAFETY: large enough, aligned to 16 bytes, and nobody else's.
        unsafe { at.write(Self { length, before: at, after: at }) };
        Some(at)
    }

    /// Frees a link that no other link knows.
    ///
    /// # Safety
    /// `at` is from [`Link::new`], and nobody uses it any more.
    unsafe fn free(at: NonNull<Self>) {
        // SAFETY: as the caller promises; the length is that of `new`.
        drop(unsafe { Block::of_raw(at.cast(), size_of::<Self>() + at.read().length) });
    }
}

impl Chain {
    /// A chain without blocks; `None` if there is no memory.
    #[must_use]
    pub fn new() -> Option<Self> {
        Some(Self { ends: Link::new(0)? })
    }

    /// A block with this content, by the pointer that is handed out; `None` if there is no memory.
    pub fn add(&mut self, content: &[u8]) -> Option<NonNull<c_void>> {
        let link = Link::new(content.len())?;
        // SAFETY: the new link is nobody else's, and those of the chain live as long as it does.
        unsafe {
            Self::content(link.cast()).copy_from_slice(content);
            let after = self.ends.read().after;
            (*link.as_ptr()).before = self.ends;
            (*link.as_ptr()).after = after;
            (*after.as_ptr()).before = link;
            (*self.ends.as_ptr()).after = link;
        }
        Some(link.cast())
    }

    /// The content of a block.
    ///
    /// # Safety
    /// `block` is from [`Chain::add`], and neither it nor its chain was freed.
    #[must_use]
    pub const unsafe fn content<'a>(block: NonNull<c_void>) -> &'a mut [u8] {
        // SAFETY: as the caller promises; the content has the length of its link.
        unsafe {
            let length = block.cast::<Link>().read().length;
            let at = block.cast::<u8>().add(size_of::<Link>());
            core::slice::from_raw_parts_mut(at.as_ptr(), length)
        }
    }

    /// Frees a block.
    ///
    /// # Safety
    /// As for [`Chain::content`]; nobody uses the block any more.
    pub unsafe fn free(block: NonNull<c_void>) {
        let link = block.cast::<Link>();
        // SAFETY: as the caller promises, so its neighbours are there too.
        unsafe {
            let Link { before, after, .. } = link.read();
            (*before.as_ptr()).after = after;
            (*after.as_ptr()).before = before;
            Link::free(link);
        }
    }
}

impl Drop for Chain {
    fn drop(&mut self) {
        // SAFETY: the links are those of this chain, each freed once; the last is the one of its ends.
        unsafe {
            let mut at = self.ends.read().after;
            while at != self.ends {
                let after = at.read().after;
                Link::free(at);
                at = after;
            }
            Link::free(self.ends);
        }
    }
}

/// An open file.
struct Stream(NonNull<c_void>);

impl Stream {
    fn open(path: &CStr) -> Result<Self, &'static str> {
        // SAFETY: both texts end with a zero.
        let file = unsafe { fopen(path.as_ptr(), c"rb".as_ptr()) };
        NonNull::new(file).map(Self).ok_or("the file cannot be opened")
    }

    fn length(&self) -> Option<usize> {
        let file = self.0.as_ptr();
        // SAFETY: the file is open.
        let length = unsafe {
            if fseek(file, 0, END) != 0 {
                return None;
            }
            let length = ftell(file);
            if fseek(file, 0, START) != 0 {
                return None;
            }
            length
        };
        usize::try_from(length).ok()
    }

    fn fill(&self, out: &mut [u8]) -> Option<()> {
        // SAFETY: the file is open, and `out` has that many bytes.
        let found = unsafe { fread(out.as_mut_ptr().cast(), 1, out.len(), self.0.as_ptr()) };
        (found == out.len()).then_some(())
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        // SAFETY: open, and closed once. What a file that was read says on closing does not matter.
        let _ = unsafe { fclose(self.0.as_ptr()) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    std::thread_local! {
        /// Blocks of this thread that were not given back.
        pub static BLOCKS: Cell<usize> = const { Cell::new(0) };
    }

    #[test]
    fn blocks_are_freed_one_by_one_and_the_rest_with_their_chain() {
        let mut chain = Chain::new().expect("memory");
        let blocks: std::vec::Vec<_> = (0..62u8).map(|k| chain.add(&[k; 100]).expect("memory")).collect();
        for (k, &block) in blocks.iter().enumerate() {
            // SAFETY: from this chain, and not freed yet.
            let content = unsafe { Chain::content(block) };
            assert_eq!(content, [k as u8; 100]);
        }
        for &block in blocks.iter().step_by(3) {
            // SAFETY: from this chain, and freed once.
            unsafe { Chain::free(block) };
        }
        assert_eq!(BLOCKS.with(Cell::get), 1 + 62 - 21);
        drop(chain);
        assert_eq!(BLOCKS.with(Cell::get), 0);
    }
}
