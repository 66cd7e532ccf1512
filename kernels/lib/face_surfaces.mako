## code (fields of a code)
// Elements whose faces have surfaces of their own (photizon_cl/compile/effects/face_surfaces.py): three
// faces may, further ones have the last one's.

// A face's code with the kind of its own surface, which the element's row has for each.
FN lint with_surface(__global const double *row, lint code) {
    const lint face = FACE_OF(code);
    const lint kind = SELI(IEQ(face, lsplat(0L)), lsplat((long)row[FACES_FIRST]),
                           SELI(IEQ(face, lsplat(1L)), lsplat((long)row[FACES_SECOND]), lsplat((long)row[FACES_THIRD])));
    return (code & ~(${code["surface"].mask}L << ${code["surface"].shift})) | (kind << ${code["surface"].shift});
}

// Which of the places in the material table is a face's: each element has three.
FN lint material_of_face(lint code) {
    const lint face = FACE_OF(code);
    return ELEMENT_OF(code) * 3L + SELI(IGT(face, lsplat(2L)), lsplat(2L), face);
}
