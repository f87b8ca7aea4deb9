//! PNG files as programs write them.

pub use png;

/// The bytes of a PNG file of `stored` pixels, row after row from the top, each row of whole bytes. An indexed image has a palette of greys.
///
/// # Panics
/// If `stored` is not as long as such an image.
pub fn png_bytes(width: usize, height: usize, colour: png::ColorType, depth: png::BitDepth, stored: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    if colour == png::ColorType::Indexed {
        encoder.set_palette((0..=255).flat_map(|value| [value; 3]).collect::<Vec<u8>>());
    }
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(stored).unwrap();
    writer.finish().unwrap();
    bytes
}

/// The bytes of a grey PNG file of 8 bits.
///
/// # Panics
/// If there are not width times height values.
pub fn grey_png(width: usize, height: usize, values: &[u8]) -> Vec<u8> {
    png_bytes(width, height, png::ColorType::Grayscale, png::BitDepth::Eight, values)
}
