## counts (COATING_ …: places in a coating's head; columns of nodes and layers)
// Coatings: what a face reflects and lets pass instead of what Fresnel's formulas say.
//
// Every kind has one function, coat_<kind>(film, m, &r, &t): of the lanes in m the parts that are reflected
// and that pass.  Where nothing passes, beyond the critical angle, what r and t come to is reflected
// (effects/coatings.mako).
% for name, place in counts.items():
% if name.startswith(("COATING_", "ANGLE_NODE_", "LAYER_", "SIZE_OF_")):
#define ${name} ${place}
% endif
% endfor

// How a ray meets a coated face.  plus: whether it comes from the + side, which is outside; sin2, ci: of the
// angle of incidence, the square of its sine from the part along the face; ct2, ct: cos^2 of the angle behind
// the face by Snell's law, negative beyond the critical angle, and its root, 0 there; m: the index before the
// face over that behind.  head: where in codes it stands what the coating has.
typedef struct {
    const material_t *material;
    mask plus;
    real ci, sin2, ct, ct2, m;
    lint head;
% if amplitudes:
    const incident_t *light;
    amplitudes_t *back, *on;   // of what is reflected and what passes; alike for s and p unless a kind says more
% endif
} film_t;

FN lint film_place(const film_t *film, int column) { return gather_long(film->material->scene->codes + column, film->head); }
