//! Tests how the size of an image is read from its header.

use mocap_render::internals::image_size;

#[test]
fn the_header_of_each_format_tells_the_size() {
    let png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x02\0\0\0\x01\0";
    assert_eq!(image_size(png), Some(("image/png", [512, 256])));
    let jpeg = b"\xFF\xD8\xFF\xE0\0\x04ab\xFF\xC2\0\x0B\x08\x01\0\x02\0\x03";
    assert_eq!(image_size(jpeg), Some(("image/jpeg", [512, 256])));
    let lossless = b"RIFF....WEBPVP8L....\x2F\xFF\xC1\x3F\0";
    assert_eq!(image_size(lossless), Some(("image/webp", [512, 256])));
    let extended = b"RIFF....WEBPVP8X....\0\0\0\0\xFF\x01\0\xFF\0\0";
    assert_eq!(image_size(extended), Some(("image/webp", [512, 256])));
    for cut in 0..png.len() {
        assert_eq!(image_size(&png[..cut]), None);
    }
    assert_eq!(image_size(b"\xFF\xD8\xFF\xE0\0\0\0"), None);
}
