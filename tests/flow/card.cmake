# A card's settings and their page.
add_test(NAME Card.TheWiringIsDrawnAsItsSettingsAre COMMAND ${PROJECT_SOURCE_DIR}/device/card/draw_wiring --check)
