"""What follows from the faces of elements: neighbours, contact, wedges, boxes, areas, outlines."""
