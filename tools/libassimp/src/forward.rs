//! Functions that only the system's Assimp has, and the tables of C++ classes.
//!
//! Each such symbol is a stub: two instructions that jump to the address in its entry. At first, this is the address of
//! a routine that opens the system's Assimp, looks the symbol up, and writes the symbol's address into the entry.
//! Arguments of every type and number pass unchanged. A call of such a function without the system's Assimp ends the
//! program with a message, because no return value would be right. The dynamic linker does the same for a missing
//! symbol.

mod functions;
pub(crate) mod objects;
mod shared_ptr;

use std::ffi::{CStr, c_void};
use std::sync::atomic::{AtomicPtr, Ordering};

use crate::system::system;

/// The entry of a stub. The assembler code below needs `target` as the first field.
#[repr(C)]
pub(crate) struct Entry {
    target: AtomicPtr<c_void>,
    symbol: &'static CStr,
    /// For a virtual function without a symbol: its index in the table of the symbol.
    word: Option<usize>,
}

impl Entry {
    pub(crate) const fn function(symbol: &'static CStr) -> Self {
        Self {
            target: AtomicPtr::new(find_target as *mut c_void),
            symbol,
            word: None,
        }
    }

    pub(crate) const fn virtual_function(table: &'static CStr, word: usize) -> Self {
        Self {
            target: AtomicPtr::new(find_target as *mut c_void),
            symbol: table,
            word: Some(word),
        }
    }
}

/// Sets the target of an `Entry`, then jumps to it. A stub calls this routine with the entry's address in `r11`, which
/// calls do not preserve. The routine keeps all registers that may hold arguments.
#[unsafe(naked)]
unsafe extern "C" fn find_target() {
    std::arch::naked_asm!(
        "push rbp",
        "mov rbp, rsp",
        "push rdi",
        "push rsi",
        "push rdx",
        "push rcx",
        "push r8",
        "push r9",
        "push rax",
        "push r10",
        "sub rsp, 128",
        "movups [rsp], xmm0",
        "movups [rsp + 16], xmm1",
        "movups [rsp + 32], xmm2",
        "movups [rsp + 48], xmm3",
        "movups [rsp + 64], xmm4",
        "movups [rsp + 80], xmm5",
        "movups [rsp + 96], xmm6",
        "movups [rsp + 112], xmm7",
        "mov rdi, r11",
        "call {target_of}",
        "mov r11, rax",
        "movups xmm0, [rsp]",
        "movups xmm1, [rsp + 16]",
        "movups xmm2, [rsp + 32]",
        "movups xmm3, [rsp + 48]",
        "movups xmm4, [rsp + 64]",
        "movups xmm5, [rsp + 80]",
        "movups xmm6, [rsp + 96]",
        "movups xmm7, [rsp + 112]",
        "add rsp, 128",
        "pop r10",
        "pop rax",
        "pop r9",
        "pop r8",
        "pop rcx",
        "pop rdx",
        "pop rsi",
        "pop rdi",
        "pop rbp",
        "jmp r11",
        target_of = sym target_of,
    )
}

/// The target of a stub. Ends the process if there is no target.
extern "C" fn target_of(entry: &Entry) -> *const c_void {
    let target = system().and_then(|system| {
        let missing = || Err("it has no such symbol".to_owned());
        let address = system.find(entry.symbol);
        match entry.word {
            _ if address.is_null() => missing(),
            None => Ok(address),
            // SAFETY: a table of the same class in the same version is as long, and its words are addresses.
            Some(word) => Ok(unsafe { address.cast::<*mut c_void>().add(word).read() }),
        }
    });
    match target {
        Ok(target) => {
            entry.target.store(target, Ordering::Relaxed);
            target
        }
        Err(reason) => {
            let symbol = entry.symbol.to_string_lossy();
            eprintln!("libassimp: the program calls {symbol}, which the system's Assimp has to do: {reason}");
            std::process::abort()
        }
    }
}

/// Defines stubs for functions, each under its symbol.
macro_rules! forwarded {
    ($($symbol:ident)*) => {
        $(const _: () = {
            static ENTRY: crate::forward::Entry = crate::forward::Entry::function(
                match std::ffi::CStr::from_bytes_with_nul(concat!(stringify!($symbol), "\0").as_bytes()) {
                    Ok(symbol) => symbol,
                    Err(_) => unreachable!(),
                },
            );

            #[unsafe(naked)]
            #[unsafe(no_mangle)]
            unsafe extern "C" fn $symbol() {
                std::arch::naked_asm!("lea r11, [rip + {entry}]", "jmp [r11]", entry = sym ENTRY)
            }
        };)*
    };
}
pub(crate) use forwarded;
